function answer = armbridge(board, request, varargin)
  % Asks a board that `armbridge serve board --json` serves, in MATLAB or GNU Octave:
  %
  %   board = tcpclient("127.0.0.1", 7002);
  %   armbridge(board, "move", "angle_rad", [0.2 -0.1], "duration_s", 1);
  %
  % The answer is a structure; a failure is an error.
  write(board, [uint8(jsonencode(struct("do", request, varargin{:}))) 10]);
  text = uint8([]);
  while isempty(text) || text(end) ~= 10
    text = [text read(board, max(1, board.NumBytesAvailable))];
  end
  answer = jsondecode(char(text));
  if ~answer.ok
    error(["armbridge:" answer.error], "%s", answer.text);
  end
end
