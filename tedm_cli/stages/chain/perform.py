"""run: what has to run of the chain, in processes of their own, until all is up to date or a command is refused."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from tedm_cli.chain.graph import Step
from tedm_cli.chain.stale import Queue
from tedm_cli.files.store import replacing
from tedm_cli.progress import Step as Progress
from tedm_cli.stages.chain.make_rules import remember
from tedm_cli.stages.chain.plan import Plan
from tedm_cli.stages.chain.workers import Answer, Workers


@dataclass(frozen=True)
class Way:
    """How the steps of a chain are run.

    Parameters
    ----------
    worker : the program that runs commands (`Workers`).
    options : what every command is told of project and build folder, where they are not found from here.
    solver : the user's own solver, as `tedm solve --run` takes it; None for the embedded one.
    jobs : how many commands may run at once.
    """

    worker: tuple[str, ...]
    options: tuple[str, ...]
    solver: str | None
    jobs: int


def perform(
    plan: Plan, way: Way, begun: Callable[[Step], None], ended: Callable[[Step, Answer], None], progress: Progress
) -> Answer | None:
    """Run the steps that have to run; the first that is refused keeps others from beginning, and is returned.

    What has been made then is kept, and a plan made anew goes on from there.

    Raises
    ------
    TedmError : a process has died.
    InputError : the build folder cannot be written.
    """
    remember(plan.remembered)
    queue, of_command = Queue(plan.stale), {step.command: step for step in plan.stale}
    refused: Answer | None = None
    number = 0
    progress(number, len(plan.stale), "steps")
    with Workers(way.worker, min(way.jobs, len(plan.stale))) as workers:
        while True:
            while refused is None and workers.has_room and (step := queue.next()) is not None:
                begun(step)
                workers.begin(step.command, [*_solver(step, way.solver), *way.options])
            if not workers.are_busy:
                return refused
            command, answer = workers.wait()
            step, number = of_command[command], number + 1
            progress(number, len(plan.stale), "steps")
            ended(step, answer)
            if answer.code:
                refused = refused or answer
                continue
            for path in step.outputs if step.stamp else ():
                with replacing(path) as temporary:
                    temporary.touch()
            queue.done(step)


def _solver(step: Step, solver: str | None) -> Sequence[str]:
    return ["--run", solver] if step.stage == "solve" and solver is not None else []
