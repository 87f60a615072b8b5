"""The papers behind what ran, as BibTeX."""

from typing import Any

PAPERS = {
    "HHdD16": """@article{HHdD16,
  author = {Heitz, Eric and Hanika, Johannes and d'Eon, Eugene and Dachsbacher, Carsten},
  title = {Multiple-Scattering Microfacet {BSDF}s with the {S}mith Model},
  journal = {ACM Transactions on Graphics}, volume = {35}, number = {4}, year = {2016}
}""",
    "WJFYHY22": """@article{WJFYHY22,
  author = {Wang, Beibei and Jin, Wenhua and Fan, Jiahui and Yang, Jian and Holzschuch, Nicolas
    and Yan, Ling-Qi},
  title = {Position-Free Multiple-Bounce Computations for {S}mith Microfacet {BSDF}s},
  journal = {ACM Transactions on Graphics}, volume = {41}, number = {4}, year = {2022}
}""",
    "BdE22": """@article{BdE22,
  author = {Bitterli, Benedikt and d'Eon, Eugene},
  title = {A Position-Free Path Integral for Homogeneous Slabs and Multiple Scattering on {S}mith
    Microfacets},
  journal = {Computer Graphics Forum}, volume = {41}, number = {4}, year = {2022}
}""",
    "KC17": """@incollection{KC17,
  author = {Kulla, Christopher and Conty, Alejandro},
  title = {Revisiting Physically Based Shading at {I}mageworks},
  booktitle = {SIGGRAPH Courses: Physically Based Shading in Theory and Practice}, year = {2017}
}""",
    "Tur19": """@techreport{Tur19,
  author = {Turquin, Emmanuel},
  title = {Practical Multiple Scattering Compensation for Microfacet Models},
  institution = {Industrial Light \\& Magic}, year = {2019}
}""",
    "Heitz15": """@techreport{Heitz15,
  author = {Heitz, Eric},
  title = {Generating Procedural {B}eckmann Surfaces}, year = {2015}
}""",
    "RBSM17": """@article{RBSM17,
  author = {Ribardi{\\`e}re, Micka{\\"e}l and Bringier, Beno{\\^i}t and Meneveaux, Daniel
    and Simonot, Lionel},
  title = {{STD}: {S}tudent's t-Distribution of Slopes for Microfacet Based {BSDF}s},
  journal = {Computer Graphics Forum}, volume = {36}, number = {2}, year = {2017}
}""",
}

OF_METHOD = {
    "position-free-uncorrelated": "WJFYHY22",
    "position-free-correlated": "WJFYHY22",
    "exact": "BdE22",
    "energy-compensated": "KC17",
    "turquin": "Tur19",
}

OF_COMMAND = {
    "simulate": ("Heitz15",),
    "compare": ("Heitz15",),
    "figures": ("WJFYHY22", "Heitz15"),
}


def papers(command: str, options: dict[str, Any]) -> list[str]:
    """BibTeX entries of the papers behind a run: the model, what made its surfaces, its slopes and
    its methods."""
    methods = options.get("method") or ()
    keys = ["HHdD16", *OF_COMMAND.get(command, ())]
    keys += ["RBSM17"] if options.get("slopes") == "student-t" else []
    keys += [OF_METHOD.get(name, "") for name in methods if isinstance(name, str)]
    return [PAPERS[key] for key in dict.fromkeys(keys) if key]
