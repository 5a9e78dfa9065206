% MATLAB, and GNU Octave with its package instrument-control.
if exist("OCTAVE_VERSION", "builtin"), pkg("load", "instrument-control"); end
board = tcpclient("127.0.0.1", 7002);
armbridge(board, "arm");
armbridge(board, "regulate", "angle_rad", [0 0]);
armbridge(board, "move", "angle_rad", [0.2 -0.1], "duration_s", 1);
armbridge(board, "take");
ticks = armbridge(board, "take", "ticks", 500).columns;
armbridge(board, "park");
fprintf("angles %.3f and %.3f rad\n", mean(ticks.angle_rad_1), mean(ticks.angle_rad_2));
clear board
