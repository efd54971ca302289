"""A bench without webcams needs nothing of V4L2."""

import subprocess
import sys

PROGRAM = """
import sys
import drivers.cameras
import drivers.cameras.frame_sets
print("linuxpy" in sys.modules)
"""


def test_only_webcams_import_linuxpy():
    said = subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
    assert said.stdout == "False\n"
