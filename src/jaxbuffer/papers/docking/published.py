"""The paper's own equations as a set: the damper of eq. 10 (M24) and the frozen arms of eq. 21 (M34)."""

from collections.abc import Callable

from ...fields import replace
from ..study import Claim, ClaimVerdict, PaperPart, Rows, Study

EQUATIONS = {"buffer.damping": "published", "contact.arms": "published"}
SUFFIX = "_published"


def as_published(part: PaperPart) -> PaperPart:
    """Return the same studies and claims with the paper's equations."""
    return part._replace(studies=tuple(map(_study, part.studies)), claims=tuple(map(_claim, part.claims)))


def _study(study: Study) -> Study:
    cases = tuple(case._replace(design=replace(case.design, EQUATIONS)) for case in study.cases)
    return study._replace(name=study.name + SUFFIX, title=f"{study.title}, equations 10 and 21", cases=cases)


def _claim(claim: Claim) -> Claim:
    return claim._replace(claim=f"{claim.claim} (equations 10 and 21)", judge=_of_published(claim.judge))


def _of_published(judge: Callable[[Rows], ClaimVerdict]) -> Callable[[Rows], ClaimVerdict]:
    # The same judges read these rows under the names of the others.
    return lambda rows: judge({n.removesuffix(SUFFIX): made for n, made in rows.items() if n.endswith(SUFFIX)})
