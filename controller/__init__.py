"""Shape estimates and a target in, tendon commands out: pure decisions, and the process that runs them 200 times a second."""
