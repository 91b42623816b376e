"""What is mended in robosuite's models."""

import mujoco
import numpy as np
import pytest

from lfr.errors import LfrError
from lfr.robots import ROBOTS
from lfr.robots.repair import Coupling, Repair
from lfr.sim import scene
from lfr.sim.simulation import simulation
from tests.sim.pairs import EMBODIMENTS, still

MODEL = """<mujoco><worldbody>
  <body name="robot0_base" pos="1 0 0"><geom size=".1"/>
    <body name="link" pos="0 0 1"><joint name="a"/><geom size=".1"/><site name="s" pos="0 0 2"/>
      <body name="finger"><joint name="b"/><geom size=".1"/></body></body></body>
  </worldbody>
  <tendon><fixed name="x_cpl"><joint joint="a" coef="1"/></fixed></tendon>
  <equality><tendon tendon1="x_cpl"/></equality></mujoco>"""


@pytest.mark.parametrize("name", EMBODIMENTS)
def test_an_arm_holds_its_pose(name: str) -> None:
    engine = simulation(name, "lift")
    before = engine.reset(0)[:3]
    after = engine.step(still(name, 100)).observations[-1, :3]
    assert np.linalg.norm(after - before) < 2e-4
    assert np.abs(engine.joint_velocity()).max() < 1e-3


def test_each_change_is_in_the_model_that_mujoco_builds() -> None:
    repair = Repair(
        excluded_contacts=(("link", "finger"),),
        couplings=(Coupling("b", "a", -2.0, 0.5),),
        dropped_tendons=("_cpl",),
        sites_in_base=("s",),
        attributes=(("joint", "a", "damping", "3"),),
        shifts=(("body", "robot0_base", (0.1, 0.0, 0.0)),),
    )
    model = mujoco.MjModel.from_xml_string((Repair() + repair).applied(MODEL))
    assert model.ntendon == 0
    assert model.nexclude == 1
    assert model.neq == 1
    np.testing.assert_allclose(model.eq_data[0, :2], [0.5, -2.0])
    assert model.dof_damping[0] == 3
    assert model.body("robot0_base").pos[0] == pytest.approx(1.1)
    assert model.site("s").bodyid[0] == model.body("robot0_base").id
    np.testing.assert_array_equal(model.site("s").pos, 0)


def test_nothing_to_mend_leaves_the_text_as_it_is() -> None:
    assert Repair().applied(MODEL) is MODEL
    assert ROBOTS["panda"].repaired(MODEL) is MODEL


def test_what_is_mended_is_said() -> None:
    for robot in ROBOTS.values():
        assert bool(robot.repairs.why) == (robot.repairs != Repair())
        assert all(why[0].isupper() and why.endswith(".") for why in robot.repairs.why)


def test_a_model_without_the_named_joints_is_refused_in_one_line() -> None:
    model = mujoco.MjModel.from_xml_string(MODEL)
    with pytest.raises(
        LfrError, match="panda: found joints a, b and 0 actuators; expected"
    ) as told:
        scene._check_layout(model, ROBOTS["panda"])
    assert "\n" not in str(told.value)
