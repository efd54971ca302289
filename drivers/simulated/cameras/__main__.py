"""`python -m drivers.simulated.cameras DESCRIPTOR`: started by the simulated bench, one for each camera."""

import sys

from drivers.simulated.cameras.worker import serve

serve(int(sys.argv[1]))
