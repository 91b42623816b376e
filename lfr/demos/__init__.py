"""Scripted demonstrations: the waypoint expert and the recorder."""
