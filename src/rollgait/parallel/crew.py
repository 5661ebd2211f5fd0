"""Work in processes of this machine, of which one that dies takes only its own job along.

joblib's own processes share one pipe for all results: where one dies while it writes there, the caller waits
for ever. Here each has pipes of its own.
"""

from __future__ import annotations

import queue
from collections import Counter, deque
from collections.abc import Callable, Iterable, Iterator
from typing import Any, Final, TypeVar

from rollgait.child import Child, Unreadable, unpickled
from rollgait.errors import RollgaitError
from rollgait.parallel.messages import Begun, Done, Failed, Ready
from rollgait.parallel.threads import ONE_THREAD

IN_FLIGHT: Final = 2
"""Jobs that a process has at once: the one it does, and the next."""
SUSPECT: Final = 2
"""A job is given up when so many processes died doing it: most deaths are of a machine, not of a job."""
BEGINNINGS: Final = 3
"""So many times their number of processes in a row may die as they begin."""
LOOK: Final = 0.5
"""s, after which waiting looks up: where a lock cannot be interrupted, Ctrl-C is heard then."""

JobT = TypeVar("JobT")
ResultT = TypeVar("ResultT")


def results_of_crew(
    call: Callable[[JobT], ResultT],
    jobs: Iterable[JobT],
    count: int,
    died: Callable[[JobT], ResultT],
) -> Iterator[ResultT]:
    """As `results`, by so many processes of this machine."""
    crew = _Crew(call, enumerate(jobs), count)
    try:
        while crew.hand_out():
            member, answer = crew.next_answer()
            match answer:
                case None:
                    yield from map(died, crew.lost(member))
                case Ready():
                    crew.has_come(member)
                case Begun():
                    member.is_busy = True
                case _:
                    member.is_busy = False
                    member.jobs.popleft()
                    yield _result(answer)
    finally:
        crew.close()


def _result(answer: Done | Failed | Unreadable) -> Any:
    """What came of a job, or its error."""
    if isinstance(answer, Done):
        return answer.result
    if isinstance(answer, Unreadable):
        raise RollgaitError(f"what a worker sent cannot be read: {answer.reason}")
    raise _error(answer)


def _error(failed: Failed) -> Exception:
    """What a job raised; in words, if it is of a kind that cannot be read."""
    found = None if failed.error is None else unpickled(failed.error)
    return found if isinstance(found, Exception) else RollgaitError(failed.text)


class _Crew:
    """The processes, what is left to do, and what they say."""

    def __init__(self, call: Callable[[Any], Any], jobs: Iterator[tuple[int, Any]], count: int) -> None:
        self._call, self._jobs, self._count = call, jobs, count
        self._again: deque[tuple[int, Any]] = deque()
        self._members: list[_Member] = []
        self._said: queue.SimpleQueue[tuple[_Member, Any]] = queue.SimpleQueue()
        self._deaths: Counter[int] = Counter()
        self._ended_at_once = 0

    def hand_out(self) -> bool:
        """Gives each process what it may have; False if all is done."""
        for has in range(IN_FLIGHT):
            for place in range(self._count):
                if place < len(self._members) and len(self._members[place].jobs) > has:
                    continue
                job = self._again.popleft() if self._again else next(self._jobs, None)
                if job is None:
                    return any(member.jobs for member in self._members)
                if place == len(self._members):
                    self._members.append(_Member())
                    self._members[place].begin(self._call, self._said)
                self._members[place].give(job)
        return True

    def next_answer(self) -> tuple[_Member, Any]:
        """Who says something, and what; None if it has ended."""
        while True:
            try:
                return self._said.get(timeout=LOOK)
            except queue.Empty:
                continue

    def has_come(self, member: _Member) -> None:
        """A process is ready for its first job."""
        member.is_ready = True
        self._ended_at_once = 0

    def lost(self, member: _Member) -> list[Any]:
        """Takes leave of a process that has ended. Its jobs are done again; returned is the one that is not.

        Raises:
            RollgaitError: so many have ended before their first job.
        """
        member.close()
        self._members.remove(member)
        given_up = []
        if not member.is_ready:
            self._ended_at_once += 1
            if self._ended_at_once == BEGINNINGS * self._count:
                raise RollgaitError(
                    f"no worker stays alive: {self._ended_at_once} in a row ended as they began"
                )
        elif member.is_busy:
            number, job = member.jobs[0]
            self._deaths[number] += 1
            if self._deaths[number] == SUSPECT:
                member.jobs.popleft()
                given_up.append(job)
        self._again.extendleft(reversed(member.jobs))
        return given_up

    def close(self) -> None:
        """Ends all processes."""
        for member in self._members:
            member.kill()
        for member in self._members:
            member.close()


class _Member:
    """A process and the jobs that it has, first the one that it does.

    Attributes:
        jobs: with their numbers.
        is_ready: whether it can do jobs.
        is_busy: whether it has begun with the first.
    """

    def __init__(self) -> None:
        self.jobs: deque[tuple[int, Any]] = deque()
        self.is_ready = self.is_busy = False
        self._child: Child | None = None

    def begin(self, call: Callable[[Any], Any], said: queue.SimpleQueue[tuple[_Member, Any]]) -> None:
        """Starts the process, and says what is to be done with jobs."""
        self._child = Child(
            "rollgait.parallel.member",
            heard=lambda answer: said.put((self, answer)),
            ended=lambda: said.put((self, None)),
            environment=ONE_THREAD,
        )
        self._child.tell(call)

    def give(self, job: tuple[int, Any]) -> None:
        """One job more. That a process has ended, and does not hear it, will be said."""
        assert self._child is not None
        self.jobs.append(job)
        self._child.tell(job[1])

    def kill(self) -> None:
        if self._child is not None:
            self._child.kill()

    def close(self) -> None:
        if self._child is not None:
            self._child.close()
