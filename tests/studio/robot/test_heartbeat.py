"""Heartbeat of a page: an answer counts from its question, and a page that hangs is not flooded."""

import time

import pytest

pytest.importorskip("viser", reason="viser is not installed")

from viser import _messages

from spiraltrunk.studio.robot.heartbeat import MOST_OPEN, PageHeartbeat


class FakeClient:
    """A client that keeps its messages."""

    def __init__(self):
        self._websock_connection = self
        self.asked = []

    def register_handler(self, kind, handler):
        assert kind is _messages.LocalStorageGetItemResponseMessage
        self.answer_by = handler

    def queue_message(self, message):
        self.asked.append(message.request_uuid)

    def answer(self, name):
        self.answer_by(0, _messages.LocalStorageGetItemResponseMessage(value=None, error=None, request_uuid=name))


@pytest.fixture
def page():
    client, answers = FakeClient(), []
    return client, PageHeartbeat(client, answers.append), answers


def test_an_answer_has_the_time_of_its_question(page):
    client, heartbeat, answers = page
    before = time.monotonic()
    heartbeat.ask()
    after = time.monotonic()
    heartbeat.ask()
    client.answer(client.asked[0])
    assert len(answers) == 1
    assert before <= answers[0] <= after


def test_an_answer_counts_once_and_an_invented_one_never(page):
    client, heartbeat, answers = page
    heartbeat.ask()
    for name in ("", "1", client.asked[0][:-1] + "2", client.asked[0], client.asked[0]):
        client.answer(name)
    assert len(answers) == 1


def test_a_page_that_hangs_is_not_flooded(page):
    client, heartbeat, answers = page
    for _ in range(10 * MOST_OPEN):
        heartbeat.ask()
    assert len(client.asked) == MOST_OPEN
    for name in client.asked:
        client.answer(name)
    heartbeat.ask()
    assert len(client.asked) == MOST_OPEN + 1
    assert len(answers) == MOST_OPEN
