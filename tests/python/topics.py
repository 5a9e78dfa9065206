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
}
