"""Simulation: robosuite builds the scenes, a compiled kernel steps them.

Where the engine departs from stock robosuite 1.5.2, and by how much:

- What is broken in robosuite's models is mended (`lfr.robots.repair`), in `stock` too.
- The first substep after a reset uses the present mass matrix, in `stock` too; stock robosuite's
  own use of a stale one moves joints by about 1e-6 rad in 200 steps.
- The proximal arm links and the mount do not collide. Nothing changes until they touch something.
- Bodies that cannot move have no mass, or are absent: what changes is the rounding.
- Objects that a task does not use are absent. Stock's dense reward for the can and the nut counts
  them as lifted during the first 1.3 s, if the hand holds something by then.
- Observations belong to the instant after a step; stock's observables are 2 ms older. Reward and
  success are taken where stock takes them.
- Contact-free motion agrees to 1e-7 rad over 60 steps; in contact, rounding grows as it does
  between any two builds of MuJoCo.
"""
