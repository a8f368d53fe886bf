"""The paper's own equations as a set: the damper of eq. 10 (M24) and the frozen arms of eq. 21 (M34)."""

from ...fields import replace
from ..study import Judge, PaperPart, Study

EQUATIONS = {"buffer.damping": "published", "contact.arms": "published"}
SUFFIX = "_published"


def as_published(part: PaperPart) -> PaperPart:
    """Return the same studies and claims with the paper's equations."""

    def of_published(judge: Judge) -> Judge:
        # The same judges read these rows under the names of the others.
        return lambda rows: judge({n.removesuffix(SUFFIX): made for n, made in rows.items() if n.endswith(SUFFIX)})

    claims = tuple(
        claim._replace(claim=f"{claim.claim} (equations 10 and 21)", judge=of_published(claim.judge))
        for claim in part.claims
    )
    return part._replace(studies=tuple(map(_study, part.studies)), claims=claims)


def _study(study: Study) -> Study:
    cases = tuple(case._replace(design=replace(case.design, EQUATIONS)) for case in study.cases)
    return study._replace(name=study.name + SUFFIX, title=f"{study.title}, equations 10 and 21", cases=cases)
