"""BC+RNN, the paper's imitation baseline: a recurrent policy that clones demonstrations."""
