"""Learn from Robot: transfer manipulation skills from one robot arm to another."""

__version__ = "0.2.0"
