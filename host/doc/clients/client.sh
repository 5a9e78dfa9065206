#!/bin/sh
# A shell with nc: the requests of a motion, and the last answer. The board parks the arm or lets
# go of it when nc ends.
{
    echo '{"do":"arm"}'
    echo '{"do":"regulate","angle_rad":[0,0]}'
    echo '{"do":"move","angle_rad":[0.2,-0.1],"duration_s":1}'
    echo '{"do":"status"}'
    sleep 3
} | nc -N "${1:-127.0.0.1}" "${2:-7002}" | tail -n 1
