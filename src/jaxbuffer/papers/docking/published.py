"""The paper's own equations as a set: the damper of eq. 10 (M24) and the frozen arms of eq. 21 (M34)."""

from ...fields import replace
from ..study import PaperPart, Study

EQUATIONS = {"buffer.damping": "published", "contact.arms": "published"}
SUFFIX = "_published"


def as_published(part: PaperPart) -> PaperPart:
    """Return the same studies and claims with the paper's equations."""
    claims = tuple(claim._replace(claim=f"{claim.claim} (equations 10 and 21)", suffix=SUFFIX) for claim in part.claims)
    return part._replace(studies=tuple(map(_study, part.studies)), claims=claims)


def _study(study: Study) -> Study:
    cases = tuple(case._replace(design=replace(case.design, EQUATIONS)) for case in study.cases)
    return study._replace(name=study.name + SUFFIX, title=f"{study.title}, equations 10 and 21", cases=cases)
