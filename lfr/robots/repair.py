"""What of robosuite's models of arms and grippers is mended, and how: the one place that does it.

Each `Repair` stands with the arm or gripper that needs it; docs/simulation.md lists their effects.
The engine and stock robosuite are both given the repaired model.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass

from lfr.errors import LfrError


@dataclass(frozen=True)
class Coupling:
    """A joint that follows another one: q = offset + ratio q_driver (rad).

    ``solref`` is MuJoCo's, of the constraint: time constant (s) and damping ratio.
    """

    joint: str
    driver: str
    ratio: float
    offset: float = 0.0
    solref: str = "0.02 1"


@dataclass(frozen=True)
class Repair:
    """Changes to an MJCF, by the names that robosuite gives its elements.

    Attributes:
        why: what is broken, and what is done about it: a sentence each, for cards.
        excluded_contacts: pairs of bodies whose contact is switched off.
        couplings: joints that follow others.
        dropped_tendons: ends of the names of tendons that are taken out, with what equates them.
        sites_in_base: sites that belong to the arm's base, where robosuite has them on a link.
        attributes: (tag, name, attribute, value) to be set.
        shifts: (tag, name, m) by which a position is moved, in the frame that it is given in.
    """

    why: tuple[str, ...] = ()
    excluded_contacts: tuple[tuple[str, str], ...] = ()
    couplings: tuple[Coupling, ...] = ()
    dropped_tendons: tuple[str, ...] = ()
    sites_in_base: tuple[str, ...] = ()
    attributes: tuple[tuple[str, str, str, str], ...] = ()
    shifts: tuple[tuple[str, str, tuple[float, float, float]], ...] = ()

    def __add__(self, other: Repair) -> Repair:
        return Repair(
            self.why + other.why,
            self.excluded_contacts + other.excluded_contacts,
            self.couplings + other.couplings,
            self.dropped_tendons + other.dropped_tendons,
            self.sites_in_base + other.sites_in_base,
            self.attributes + other.attributes,
            self.shifts + other.shifts,
        )

    def applied(self, xml: str) -> str:
        """The MJCF with these changes; the same text where there are none."""
        if self == Repair():
            return xml
        root = ET.fromstring(xml)
        for ending in self.dropped_tendons:
            _drop_tendons(root, ending)
        for name in self.sites_in_base:
            _move_to_base(root, name)
        for tag, name, attribute, value in self.attributes:
            _find(root, tag, name).set(attribute, value)
        for tag, name, shift in self.shifts:
            _shift(_find(root, tag, name), shift)
        contact, equality = ET.SubElement(root, "contact"), ET.SubElement(root, "equality")
        for first, second in self.excluded_contacts:
            ET.SubElement(contact, "exclude", body1=first, body2=second)
        for one in self.couplings:
            ET.SubElement(
                equality,
                "joint",
                joint1=one.joint,
                joint2=one.driver,
                polycoef=f"{one.offset:g} {one.ratio:g} 0 0 0",
                solref=one.solref,
            )
        return ET.tostring(root, encoding="unicode")


NEARER = Repair(
    why=("The base stands 7.5 cm nearer, since the bin and the peg are out of its reach.",),
    shifts=(("body", "robot0_base", (0.075, 0.0, 0.0)),),
)
"""For arms whose reach, from where robosuite puts every base, ends before the bin and the peg."""


def _find(root: ET.Element, tag: str, name: str) -> ET.Element:
    for element in root.iter(tag):
        if element.get("name") == name:
            return element
    known = ", ".join(str(element.get("name")) for element in root.iter(tag))
    raise LfrError(f"a repair is of the {tag} {name!r}, which the model lacks; it has {known}")


def _shift(element: ET.Element, shift: tuple[float, float, float]) -> None:
    there = (float(value) for value in element.get("pos", "0 0 0").split())
    element.set("pos", " ".join(f"{a + b:g}" for a, b in zip(there, shift, strict=True)))


def _drop_tendons(root: ET.Element, ending: str) -> None:
    for section in (*root.findall("tendon"), *root.findall("equality")):
        for element in list(section):
            named = element.get("name") if section.tag == "tendon" else element.get("tendon1")
            if (named or "").endswith(ending):
                section.remove(element)


def _move_to_base(root: ET.Element, name: str) -> None:
    site = _find(root, "site", name)
    for parent in root.iter():
        if site in list(parent):
            parent.remove(site)
    site.set("pos", "0 0 0")
    _find(root, "body", "robot0_base").append(site)
