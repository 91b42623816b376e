"""rerun: the scene's geometry, episodes, policies and learning runs to look at."""
