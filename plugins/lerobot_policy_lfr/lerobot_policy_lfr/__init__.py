"""By its name LeRobot finds this distribution and imports it; that registers lfr's plugin."""

from lfr.lerobot_plugin import configuration_lfr, env_config

__all__ = ["configuration_lfr", "env_config"]
