"""Virtual feed axes: motion, friction, what drives say."""
