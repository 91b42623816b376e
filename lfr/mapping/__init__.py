"""The cycle generative mapping between two arms' latent skill spaces."""
