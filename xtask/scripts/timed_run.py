"""Runs a command; its wall-clock seconds and largest resident memory, as the system tells them when it ends.

    python3 timed_run.py SECONDS STDERR COMMAND [ARGUMENT ...]

Prints JSON: {"exit": code, "seconds": s, "peak_bytes": n}. The exit code is null where a signal or the limit of SECONDS
ended it. STDERR gets what the command says. The system counts a process from before it becomes the command, so a peak
that is no larger than this script's own says nothing: it is null then. Only the command's process is ended.
"""

import json
import os
import resource
import subprocess
import sys
import threading
import time


def own_peak():
    try:
        with open("/proc/self/status") as status:
            return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM:"))
    except (OSError, StopIteration):
        return bytes_of(resource.getrusage(resource.RUSAGE_SELF))


def bytes_of(usage):
    return usage.ru_maxrss * (1 if sys.platform == "darwin" else 1024)


def main():
    limit, log, command = float(sys.argv[1]), sys.argv[2], sys.argv[3:]
    with open(log, "wb") as errors:
        begin = time.perf_counter()
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=errors)
        alarm = threading.Timer(limit, process.kill)
        alarm.start()
        _, status, usage = os.wait4(process.pid, 0)
        seconds = time.perf_counter() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        alarm.cancel()
    code, peak = process.returncode, bytes_of(usage)
    print(json.dumps({
        "exit": code if code >= 0 else None,
        "seconds": seconds,
        "peak_bytes": peak if peak > own_peak() * 1.02 else None,
    }))


main()
