"""Set-up of all tests."""

import signal

# A shell ignores the signal in what it runs in the background; tests of ctrl-C need it.
signal.signal(signal.SIGINT, signal.default_int_handler)
