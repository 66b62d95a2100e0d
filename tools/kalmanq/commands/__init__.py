"""What `kalmanq NAME` does, a module a command: its options, what it calls of the library, what it prints.

COMMANDS has a row for each: the module, and its line of help; EXAMPLES what its help ends with.  A module defines `command`,
which is made by options.command_of.
"""

STUDIES = "kalmanq_studies.commands"  # a package of its own

COMMANDS = {
    "run": ("kalmanq.commands.run",
            "Filter a CSV file; with --smooth, --lag and --forecast what was, and what is to come."),
    "check": ("kalmanq.commands.check",
              "Is the model observable, stabilisable and well conditioned, and do the ranges fit?  Are Jacobians right?"),
    "design": ("kalmanq.commands.design",
               "Formats, accuracy and costs on a core; the way to run it; the filter as a C file."),
    "compile": ("kalmanq.commands.compile",
                "C for exactly this filter, without a library: straight lines, for any constant model and any gaps."),
    "steady": ("kalmanq.commands.steady", "What the covariance settles to, the gain, and how fast the filter forgets."),
    "simulate": ("kalmanq.commands.simulate",
                 "Draw measurements of the model, as a CSV file that `run` takes; with --runs, errors over many runs."),
    "compare": ("kalmanq.commands.compare", "Every arithmetic compared with double: errors of means in sigma, and of sigmas.  "
                                            "Of a nonlinear model the methods, too."),
    "report": ("kalmanq.commands.report",
               "Does the data fit the model?  A page with a verdict, pictures and figures."),
    "fit": ("kalmanq.commands.fit", "Estimate parameters, with standard errors.  Exit code 3: no maximum; OUT then has "
                                    "the best that was found."),
    "tune": ("kalmanq.commands.tune",
             "A page in which the library runs over a recording while you move its noises; with a fit, and no server."),
    "doctor": ("kalmanq.commands.doctor", "What is installed, which compilers and emulators are there, what is missing for which command."),
    "examples": (f"{STUDIES}.examples", "The theory's examples: stationary, smoothing."),
    "gallery": (f"{STUDIES}.gallery", "Textbook models with data, fitted, smoothed and drawn: level, trend, season, "
                                      "ARMA, regression, factor, ..."),
    "study": (f"{STUDIES}.study", "Run a study of the library's behaviour, and write its findings."),
}

# In a folder with the files of kalmanq/examples: a test runs each
EXAMPLES = {
    "run": "kalmanq run track.toml my.csv --smooth --plot my.png",
    "check": "kalmanq check track.toml",
    "design": "kalmanq design track.toml --core m3 --out .",
    "compile": "kalmanq compile constant_velocity.toml -o walk.c",
    "steady": "kalmanq steady constant_velocity.toml",
    "simulate": "kalmanq simulate track.toml -n 200 --out my.csv",
    "compare": "kalmanq compare track.toml my.csv",
    "report": "kalmanq report nile.toml nile.csv -o nile.html",
    "fit": "kalmanq fit nile_guess.toml nile.csv --out fitted.toml",
    "tune": "kalmanq tune nile.toml nile.csv -o nile.html",
    "doctor": "kalmanq doctor --json",
    "examples": "kalmanq examples stationary --out stationary.png",
    "gallery": "kalmanq gallery trend-season --out .",
    "study": "kalmanq study heavy-tails --quick -o .",
}
