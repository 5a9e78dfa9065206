//! Seeds that are packets, and scripts with packets in them, in hexadecimal.

/// Packets of clients at the transparent port: to servos under control, 1 and 2, and to
/// others.
pub(crate) const TRANSPARENT_PORT: [(&str, &str); 26] = [
    ("stock-led-and-more", "FF FF 01 05 03 19 01 01 DB"),
    ("morpheus-read-speed", "AA 05 01 21 02 0D 01 C3"),
    ("morpheus-read-temperature", "AA 05 02 21 02 0E 02 C0"),
    ("morpheus-too-long", "AA 80 01 21 01"),
    ("damaged", "FF FF 01 02 01 FC AA 03 01 21 01 D7"),
    ("stock-ping", "FF FF 01 02 01 FB"),
    ("stock-read-table", "FF FF 01 04 02 00 32 C6"),
    ("stock-read-36-8", "FF FF 02 04 02 24 08 CB"),
    ("stock-led", "FF FF 01 04 03 19 01 DD"),
    ("stock-write-goal", "FF FF 01 05 03 1E 00 02 D6"),
    ("stock-write-other", "FF FF 05 05 03 1E 00 02 D2"),
    ("stock-take-id", "FF FF 05 04 03 03 01 EF"),
    (
        "stock-sync-other",
        "FF FF FE 0A 83 1E 02 05 00 02 06 00 02 45",
    ),
    (
        "stock-sync-ours",
        "FF FF FE 0A 83 1E 02 01 00 02 05 00 02 4A",
    ),
    ("stock-reset", "FF FF 05 02 06 F2"),
    ("stock-action", "FF FF FE 02 05 FA"),
    ("stock-bulk-read", "FF FF FE 09 92 00 02 01 1E 02 02 24 1D"),
    ("morpheus-ping", "AA 03 01 21 01 D6"),
    ("morpheus-read-position", "AA 05 01 21 02 0B 02 C4"),
    ("morpheus-read-eeprom", "AA 05 02 21 02 00 0B C5"),
    ("morpheus-read-ram", "AA 05 02 21 02 0B 07 BE"),
    ("morpheus-cycle", "AA 03 FF 21 07 D2"),
    ("morpheus-write-pwm", "AA 06 01 21 03 10 DC 05 DD"),
    (
        "morpheus-sync-wr",
        "AA 0B FF 21 83 10 02 01 DC 05 02 84 03 C9",
    ),
    (
        "protocol2-ping-between",
        "FF FF FD 00 01 03 00 01 19 4E FF FF 02 02 01 FA",
    ),
    (
        "flush-between",
        "FF FF FF FF FF FF FF FF FF FF FF FF AA 03 01 21 01 D6",
    ),
];

/// ROBOTIS e-Manual, and a stuffed write.
pub(crate) const PROTOCOL2: [(&str, &str); 14] = [
    ("ping", "FF FF FD 00 01 03 00 01 19 4E"),
    ("ping-answer", "FF FF FD 00 01 07 00 55 00 06 04 26 65 5D"),
    ("read-position", "FF FF FD 00 01 07 00 02 84 00 04 00 1D 15"),
    (
        "read-position-answer",
        "FF FF FD 00 01 08 00 55 00 A6 00 00 00 8C C0",
    ),
    (
        "write-goal",
        "FF FF FD 00 01 09 00 03 74 00 00 02 00 00 CA 89",
    ),
    (
        "reg-write-speed",
        "FF FF FD 00 01 09 00 04 68 00 C8 00 00 00 AE 8E",
    ),
    ("action", "FF FF FD 00 01 03 00 05 02 CE"),
    ("factory-reset", "FF FF FD 00 01 04 00 06 01 A1 E6"),
    ("reboot", "FF FF FD 00 01 03 00 08 2F 4E"),
    (
        "clear-turns",
        "FF FF FD 00 01 08 00 10 01 44 58 4C 22 B1 DC",
    ),
    (
        "sync-read",
        "FF FF FD 00 FE 09 00 82 84 00 04 00 01 02 CE FA",
    ),
    (
        "sync-write",
        "FF FF FD 00 FE 11 00 83 74 00 04 00 01 96 00 00 00 02 AA 00 00 00 82 87",
    ),
    (
        "bulk-read",
        "FF FF FD 00 FE 0D 00 92 01 90 00 02 00 02 92 00 01 00 1A 05",
    ),
    (
        "stuffed-answer",
        "FF FF FD 00 D2 0E 00 55 80 36 FF FF FD FD FF 00 FF FD 00 CF 12",
    ),
];

/// ROBOTIS e-Manual, and status packets to go with it.
pub(crate) const PROTOCOL1: [(&str, &str); 13] = [
    ("ping", "FF FF 01 02 01 FB"),
    ("ping-answer", "FF FF 01 02 00 FC"),
    ("read-36-8", "FF FF 01 04 02 24 08 CC"),
    (
        "read-36-8-answer",
        "FF FF 01 0A 00 00 02 00 00 00 00 78 20 5A",
    ),
    ("write-goal-speed", "FF FF 01 07 03 1E 00 02 00 02 D2"),
    ("reg-write-goal", "FF FF 01 05 04 1E 00 02 D5"),
    ("action", "FF FF FE 02 05 FA"),
    ("factory-reset", "FF FF 00 02 06 F7"),
    ("torque-off-all", "FF FF FE 04 03 18 00 E2"),
    (
        "sync-write-speed",
        "FF FF FE 0A 83 20 02 01 00 02 02 00 06 47",
    ),
    ("bulk-read", "FF FF FE 09 92 00 02 01 1E 02 02 24 1D"),
    ("overload-and-heat-answer", "FF FF 01 02 24 D8"),
    ("read-36-2-answer", "FF FF 01 04 00 02 01 F7"),
];

/// Recorded on a bus with the firmware, but for `refused`, made from the layout.
pub(crate) const MORPHEUS: [(&str, &str); 15] = [
    ("ping", "AA 03 01 FE 01 F9"),
    ("ping-answer", "AA 03 FE 01 01 F9"),
    ("read-position", "AA 05 01 FE 02 0B 02 E7"),
    ("read-position-answer", "AA 04 FE 01 F4 01 03"),
    ("read-temperature", "AA 05 01 FE 02 0C 04 E4"),
    (
        "read-eeprom-answer",
        "AA 0D FE 01 AA 01 02 02 28 01 0A 28 0A 00 01 D1",
    ),
    ("write-pwm", "AA 06 01 FE 03 10 DC 05 00"),
    ("write-answer", "AA 03 FE 01 04 F6"),
    ("stop-all", "AA 06 FF FE 03 10 E8 03 F8"),
    ("sync-wr", "AA 0B FF FE 83 10 02 01 DC 05 02 84 03 EC"),
    ("start", "AA 03 FF FE 06 F6"),
    (
        "cycle",
        "AA 03 FF FE 07 F5 AA 04 FE 01 01 F4 03 AA 04 FE 02 01 F5 01",
    ),
    ("drive", "AA 0D FF FE 83 0F 03 01 00 DC 05 02 00 84 03 E8"),
    ("refused", "AA 03 FE 01 08 F2"),
    ("position-2", "AA 04 FE 02 01 F5 01"),
];

/// Scripts: see the target. Each begins with a stop, from which the master
/// learns whether the bus echoes.
pub(crate) const MASTER: [(&str, &str); 10] = [
    ("stop", "00 02 02 02 02 02 02 02 02 02"),
    (
        "stop-echo",
        "00 02 02 05 02 05 02 05 02 05 02 05 02 05 02 05 02",
    ),
    (
        "ping",
        "00 02 02 02 02 02 02 02 02 02 01 00 02 00 50 03 06 AA 03 FE 01 01 F9",
    ),
    (
        "start",
        "00 02 02 02 02 02 02 02 02 02 02 02 01 50 03 0C AA 03 FE 01 01 F9 \
         AA 03 FE 02 01 F8",
    ),
    (
        "drive",
        "00 02 02 02 02 02 02 02 02 02 03 DC 05 84 03 02 02 03 0E AA 04 FE \
         01 01 F4 03 AA 04 FE 02 01 F5 01",
    ),
    (
        "drive-echo",
        "00 02 02 05 02 05 02 05 02 05 02 05 02 05 02 05 02 03 DC 05 84 03 \
         02 02 05 03 0E AA 04 FE 01 01 F4 03 AA 04 FE 02 01 F5 01",
    ),
    (
        "ask",
        "00 02 02 02 02 02 02 02 02 02 05 02 09 08 AA 05 02 FE 02 0C 04 E3 \
         02 03 09 AA 06 FE 02 01 22 00 2C A4",
    ),
    (
        "stock-drive",
        "00 02 02 02 02 02 02 02 02 02 07 80 03 DC 05 84 03 02 02 03 08 FF \
         FF 01 04 00 00 02 F8 02 02 03 08 FF FF 02 04 24 01 02 D2",
    ),
    (
        "stock-alarms",
        "00 02 02 02 02 02 02 02 02 02 07 80 03 DC 05 84 03 02 02 03 0E FF \
         FF 01 02 04 F8 FF FF 01 04 00 00 02 F8 02 02 03 08 FF FF 02 04 24 01 02 D2",
    ),
    (
        "stock-ask",
        "00 02 02 02 02 02 02 02 02 02 07 00 05 01 08 08 FF FF 01 04 02 24 \
         02 D2 02 03 08 FF FF 01 04 00 00 02 F8",
    ),
];

/// Scripts: see the target.
pub(crate) const STORE: [(&str, &str); 8] = [
    ("save", "00 01 01 00"),
    (
        "saves-and-boots",
        "01 00 00 01 01 00 00 02 01 01 00 03 01 00 00 04 01 00",
    ),
    ("full", "00 01 00 02 00 03 00 04 00 05 01 01 00 06"),
    ("save-cut", "00 01 02 02 14 00 0F 01 00 00 03"),
    ("receipt-cut", "00 01 02 02 3A 00 F0 01 00 00 03"),
    (
        "move-cut",
        "00 01 00 02 00 03 00 04 03 00 14 00 3C 01 00 00 05",
    ),
    (
        "erasing-cut",
        "00 01 00 02 00 03 00 04 03 00 3D 00 5A 01 00 00 05",
    ),
    (
        "damage",
        "00 01 00 02 04 30 00 10 01 00 05 00 04 03 00 00 00 01 00 00 03",
    ),
];
