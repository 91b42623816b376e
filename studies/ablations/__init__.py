"""Other maps, other VAEs and other priors in the places of the method's own: what does each do?"""
