"""The mechanics of cutting: geometry of an operation and the law of forces."""
