"""Skill VAE and skill priors: an arm's latent space of short action sequences."""
