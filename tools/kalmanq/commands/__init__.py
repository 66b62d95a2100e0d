"""What `kalmanq NAME` does, a module a command: its options, what it calls of the library, what it prints.

COMMANDS has a row for each: the module, and its line of help.  A module defines `command`, which is made by
options.command_of.
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
