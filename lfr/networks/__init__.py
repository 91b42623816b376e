"""Networks and an optimiser whose gradients are written out, for training on a few cores.

Networks of a few hundred units are trained by small matrix products, between which autograd and
general kernels spend as long again. What is here finds the same numbers with less beside them.
"""
