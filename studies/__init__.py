"""What a study puts beside the method: baselines, ablations, and the trials that compare them."""
