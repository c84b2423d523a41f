"""The staged routine of a ball-screw axis (P2): weight, friction, place, warming, inertia."""
