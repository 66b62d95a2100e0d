"""What the studies add to the command kalmanq, by an entry point of their package"""

from kalmanq.commands import Row

COMMANDS = {
    "examples": Row(
        "kalmanq_studies.commands.examples",
        "Show examples of the theory, with their figures: stationary, smoothing.",
        "kalmanq examples stationary --out stationary.png"),
    "gallery": Row(
        "kalmanq_studies.commands.gallery",
        "Fit, smooth and draw textbook models with their data: level, trend, season, ARMA, regression, factor, ...",
        "kalmanq gallery trend-season --out ."),
    "study": Row(
        "kalmanq_studies.commands.study",
        "Run a study of the library's behaviour, and write its findings.",
        "kalmanq study heavy-tails --quick -o ."),
}
