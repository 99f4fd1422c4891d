"""What has to run of chains, in processes of their own, until all is up to date or a command of each is refused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tedm_cli.chain.graph import Step
from tedm_cli.chain.stale import Queue
from tedm_cli.files.store import replacing
from tedm_cli.progress import Step as Progress
from tedm_cli.stages.chain.make_rules import remember
from tedm_cli.stages.chain.plan import Plan
from tedm_cli.stages.chain.workers import Answer, Job, Workers


@dataclass(frozen=True)
class Way:
    """How the steps of chains are run.

    Parameters
    ----------
    worker : the program that runs commands (`Workers`).
    solver : the user's own solver, as `tedm solve --run` takes it; None for the embedded one.
    jobs : how many commands may run at once.
    alone : what a command says on standard error is let through as it says it.
    """

    worker: tuple[str, ...]
    solver: str | None
    jobs: int
    alone: bool = False


@dataclass(frozen=True)
class Chain:
    """What has to run of one chain, and what every command is told of project and build folder."""

    plan: Plan
    options: tuple[str, ...]


Begun = Callable[[int, Step], None]
Ended = Callable[[int, Step, Answer], None]


def perform(chains: Sequence[Chain], way: Way, begun: Begun, ended: Ended, progress: Progress) -> list[Answer | None]:
    """Run the steps that have to run; of each chain the answer that refused it, None where all of it was run.

    A step that is refused keeps others of its chain from beginning; the other chains go on. What has been made is kept,
    and a plan made anew goes on from there. `begun` and `ended` are told the number of the chain.

    Raises
    ------
    InputError : a build folder cannot be written.
    """
    for chain in chains:
        remember(chain.plan.remembered)
    queues = [Queue(chain.plan.stale) for chain in chains]
    of_command = [{step.command: step for step in chain.plan.stale} for chain in chains]
    refused: list[Answer | None] = [None] * len(chains)
    total, number = sum(map(len, of_command)), 0
    progress(number, total, "steps")

    def next_step() -> tuple[int, Step] | None:
        for place, queue in enumerate(queues):
            if refused[place] is None and (step := queue.next()) is not None:
                return place, step
        return None

    with Workers(way.worker, min(way.jobs, total), alone=way.alone) as workers:
        while True:
            while workers.has_room and (found := next_step()) is not None:
                place, step = found
                begun(place, step)
                workers.begin(Job(step.command, place), [*_solver(step, way.solver), *chains[place].options])
            if not workers.are_busy:
                return refused
            job, answer = workers.wait()
            place, step, number = job.chain, of_command[job.chain][job.command], number + 1
            progress(number, total, "steps")
            ended(place, step, answer)
            if answer.code:
                refused[place] = refused[place] or answer
                continue
            for path in step.outputs if step.stamp else ():
                with replacing(path) as temporary:
                    temporary.touch()
            queues[place].done(step)


def _solver(step: Step, solver: str | None) -> Sequence[str]:
    return ["--run", solver] if step.stage == "solve" and solver is not None else []
