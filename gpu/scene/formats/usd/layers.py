"""How the names of USD files end, in lower case: each is a scene, and may be a part of another."""

LAYERS = (".usd", ".usda", ".usdc", ".usdz")
