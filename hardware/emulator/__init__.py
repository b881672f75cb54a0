"""The bench's firmware in an emulated Uno, behind a real pseudo-terminal: what a bench user runs is what is tested.

with FirmwareEmulator() as board:                # builds firmware and emulator once, then starts them
    with ServoLink(board.port) as link:          # opening the port resets the emulated Uno, as on a real one
        link.arm([1500.0, 1500.0, 1500.0])
        for pulse in board.pulses(timeout_s=1.0):    # Pulse(time_s, servo, width_us), as measured on the pins
            ...
"""

from armtwin.hardware.emulator.build import missing_packages
from armtwin.hardware.emulator.launcher import FirmwareEmulator, Pulse

__all__ = ["FirmwareEmulator", "Pulse", "missing_packages"]
