"""The processes of a bench, started and kept alive by another program than systemd: a demo, or a calibration."""
