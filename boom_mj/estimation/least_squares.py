"""Options of nonlinear least squares: when a fit has converged, and how far it may step."""

from dataclasses import dataclass


@dataclass(frozen=True)
class SolverOptions:
    """Falls are of the cost, half a sum of squares of whitened residuals.

    Attributes:
        iterations: steps at most.
        start, rough, sharp: relative falls of the cost below which a fit has converged: where starts are sought, at
            first, and at last.
        settled: fall that is not worth a step where the gap is 1.
        patience: and share of the cost beyond that of noise: what does not suffice need not be exact.
        idle: steps in a row that promise more and bring less, after which none will.
        between: looks between grid starts.
        prior: deviation of a scaled parameter: keeps what the data do not tell from running away.
        damping: to begin with.
        stuck: damping beyond which no step helps.
        longest, shortest: step of a scaled parameter.
    """

    iterations: int = 10
    start: float = 0.1
    rough: float = 1e-2
    sharp: float = 1e-4
    settled: float = 0.3
    patience: float = 1e-3
    idle: int = 2
    between: int = 10
    prior: float = 30.0
    damping: float = 1e-3
    stuck: float = 1e3
    longest: float = 10.0
    shortest: float = 1e-4


OPTIONS = SolverOptions()
