"""The lumenwalk service: HTTP, WebSocket and command line around the renderer in gpu/."""
