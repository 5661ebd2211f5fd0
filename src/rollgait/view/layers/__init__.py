"""The layers of a scene: each draws one thing of a clip and can be switched off. One file per subject."""
