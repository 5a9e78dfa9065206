% The paper's experiment: an arm let go of near upright is balanced, by torques that MATLAB
% computes at 22 Hz, and then by the board at 1 kHz.
% MATLAB, and GNU Octave with its package instrument-control.
if exist("OCTAVE_VERSION", "builtin"), pkg("load", "instrument-control"); end
board = tcpclient("127.0.0.1", 7002);
period_s = 0.045;
% For the paper's weights at this period: `armbridge design --period 45000`.
gain = [1.67 0 0.2267 0; 0 1.1353 0 0.2059];
seconds = 5;

% MATLAB computes the torques; speeds are differences of angles.
armbridge(board, "arm");
last = armbridge(board, "status").angle_rad;
begun = tic;
for k = 0:round(seconds / period_s)
  pause(k * period_s - toc(begun));
  q = armbridge(board, "status").angle_rad;
  armbridge(board, "torque", "torque_nm", -gain * [q; (q - last) / period_s]);
  last = q;
end
armbridge(board, "take");
matlab = armbridge(board, "take", "ticks", 1000, "columns", {{"angle_rad"}}).columns;

% The board computes them; dry friction is compensated. A simulated arm is brought back to where
% it began; lift a real one.
armbridge(board, "disarm");
armbridge(board, "lift");
better = containers.Map( ...
  {"controller.q", "controller.r", "estimator.kind", "setup.friction_nm"}, ...
  {[30 30 0.3 0.3], [10 10], "kalman", [0.04 0.04]});
armbridge(board, "set", "parameters", better);
pause(1);
armbridge(board, "arm");
armbridge(board, "regulate", "angle_rad", [0 0]);
pause(seconds);
armbridge(board, "take");
own = armbridge(board, "take", "ticks", 1000, "columns", {{"angle_rad"}}).columns;
armbridge(board, "park");

rms = @(ticks) 1e3 * sqrt(mean([ticks.angle_rad_1 ticks.angle_rad_2] .^ 2));
fprintf("MATLAB at 22 Hz: %.1f and %.1f mrad from upright\n", rms(matlab));
fprintf("the board at 1 kHz: %.1f and %.1f mrad from upright\n", rms(own));
clear board
