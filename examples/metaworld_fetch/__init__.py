"""Meta-World's Sawyer and Gymnasium-Robotics' Fetch: two arms and simulators of others."""
