"""The papers' figures and cases on real captures, one file each, and what goes beyond them.

Each experiment is a module of this package with ``run(settings, folder, on_progress)``, which
draws into the folder and returns a report of tables.
"""

EXPERIMENTS = {
    "fig3": "Synergy models S_A to S_D: distance to 14 captured reaches of either set.",
    "fig4": "S_A and S_C with the optimisers J^T, SVD and NJ^T.",
    "fig5": "Hand speed: captured, raw, with synergy.",
    "fig6": "One reach of either set, superposed and animated (GIF; MP4 where ffmpeg is).",
    "twosubjects": "192 motions of two persons.",
    "neighbours": "Learned sets on other targets of the same person; the fewest that serve all.",
    "anytarget": "Reaches to targets that nobody captured: every way to predict them.",
    "golf": "The second paper's golf swing on a slope of 7 degrees.",
    "reach-edit": "The second paper's reach to a new place, edited in latent and joint space.",
    "jump": "The second paper's higher jump: the root raised at the apex.",
}
"""Each experiment, a module of this package, with what it is."""
