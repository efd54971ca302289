"""How verdicts look on the page."""

from nodal.calibrate.cameras.verdict import Grade

LEVELS = {Grade.GOOD: "good", Grade.FAIR: "remarks", Grade.POOR: "bad"}
"""Classes of style.css."""
