"""Topics of a log and of the Foxglove server, each with its schema."""

TOPICS = {
    "/telemetry": "armbridge.Telemetry",
    "/commands": "armbridge.Command",
    "/events": "armbridge.Event",
    "/parameters": "armbridge.Parameters",
    "/statistics": "armbridge.Statistics",
    "/log": "foxglove.Log",
    "/joint_states": "foxglove.JointStates",
    "/tf": "foxglove.FrameTransforms",
    "/scene": "foxglove.SceneUpdate",
    "/simulation/state": "armbridge.SimulationState",
    "/simulation/push": "armbridge.SimulationPush",
}

# Those of the server; only a log of a simulation has the others.
LINK_TOPICS = {name: schema for name, schema in TOPICS.items() if not name.startswith("/simulation/")}
