"""The task that sends messages to a page wakes up, also where another thread set its event in the wrong moment."""

import asyncio
import threading

import pytest
from viser._messages import GuiCloseModalMessage
from viser.infra._async_message_buffer import AsyncMessageBuffer

from spiraltrunk.studio.server.waking_event import WakingEvent, use_waking_events


async def receive_after_a_lost_wakeup(event: asyncio.Event | None) -> bool:
    """Whether a message arrives that is queued after a thread had set the event between the check and the wait."""
    buffer = AsyncMessageBuffer(asyncio.get_running_loop(), persistent_messages=False)
    if event is not None:
        buffer.message_event = event
    windows = buffer.window_generator(client_id=0)
    waiting = asyncio.ensure_future(anext(windows))
    await asyncio.sleep(0.1)
    buffer.message_event._value = True  # As by a thread that found nobody waiting yet.
    pushing = threading.Thread(target=buffer.push, args=(GuiCloseModalMessage("one"),))
    pushing.start()
    done, _ = await asyncio.wait([waiting], timeout=1.0)
    pushing.join()
    waiting.cancel()
    await asyncio.gather(waiting, return_exceptions=True)
    await windows.aclose()
    return bool(done)


def test_the_package_loses_a_wakeup_which_is_the_reason():
    assert not asyncio.run(receive_after_a_lost_wakeup(asyncio.Event())), "viser is mended: this module can go"


def test_no_wakeup_is_lost():
    assert asyncio.run(receive_after_a_lost_wakeup(WakingEvent()))


def test_buffers_of_the_server_have_such_events():
    use_waking_events()
    use_waking_events()
    assert asyncio.run(receive_after_a_lost_wakeup(None))


def test_an_event_is_set_waited_for_and_cleared():
    async def use() -> None:
        event = WakingEvent()
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(event.wait(), 0.05)
        setting = threading.Thread(target=event.set)
        setting.start()
        setting.join()
        assert event.is_set()
        await asyncio.wait_for(event.wait(), 0.5)
        event.clear()
        assert not event.is_set()
        asyncio.get_running_loop().call_later(0.05, event.set)
        await asyncio.wait_for(event.wait(), 0.5)

    asyncio.run(use())


def test_all_messages_of_two_threads_arrive():
    async def run() -> bool:
        use_waking_events()
        buffer = AsyncMessageBuffer(asyncio.get_running_loop(), persistent_messages=False)
        names = [f"{thread} {i}" for thread in range(2) for i in range(2000)]

        def push(thread: int) -> None:
            for i in range(2000):
                buffer.push(GuiCloseModalMessage(f"{thread} {i}"))

        threads = [threading.Thread(target=push, args=(number,)) for number in range(2)]
        for thread in threads:
            thread.start()
        seen: list[str] = []
        windows = buffer.window_generator(client_id=0)
        while len(seen) < len(names):
            seen += [message.uuid for message in await asyncio.wait_for(anext(windows), 5.0)]
        await windows.aclose()
        return sorted(seen) == sorted(names)

    assert asyncio.run(run())
