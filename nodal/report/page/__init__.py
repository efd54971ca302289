"""`nodal report`: one HTML file for one recording or several, with everything in it."""
