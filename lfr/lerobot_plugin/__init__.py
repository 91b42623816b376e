"""This project's environments and policies under LeRobot's conventions for third parties.

LeRobot finds them by the distribution in `plugins/lerobot_policy_lfr`, or by
`--env.discover_packages_path=lfr.lerobot_plugin`, which imports every module here. Nothing is
imported by this one: LeRobot takes seconds to load, and `lfr export --help` need not wait for it.
"""
