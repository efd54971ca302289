"""Emulated Dynamixel X servos: real packets on a real serial device, an honest motor behind each register.

Pure: `packets` and `memory` (Protocol 2.0 and control table, written apart from the real driver's), `motor`, `servo`,
`instructions`, `bus`. Edge: `pty`. `emulated` joins them: clients in front, the mechanics of the bench behind.
"""
