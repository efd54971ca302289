"""Names for the arrays that the renderer works with."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
"""Geometry of the scene."""
Flat = NDArray[np.floating]
"""Something of each of m pixels, in single precision for speed."""
Index = NDArray[np.intp]
Labels = NDArray[np.int16]
"""(rows, columns): which part of a body a pixel may show; 0 for none."""
Pixels = NDArray[np.uint8]
"""(rows, columns, 3) blue, green, red."""
Mask = NDArray[np.bool_]
