"""A process ends at once and with its exit code, whatever a thread of it is doing."""

import subprocess
import sys
import time


def test_a_thread_that_does_not_return_holds_nothing_up() -> None:
    program = (
        "import threading, time\n"
        "from armtwin.scenarios.unwaited import leave, start_unwaited\n"
        "start_unwaited(threading.Thread(target=time.sleep, args=(60,), daemon=True))\n"
        "print('told')\n"
        "leave(130)\n"
    )
    begun = time.monotonic()
    ended = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=50, check=False)
    assert ended.returncode == 130
    assert ended.stdout == "told\n"
    assert time.monotonic() - begun < 30.0
