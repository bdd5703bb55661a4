"""The canonical names of material numbers: SI unit and meaning, in one table.

A law, heat model or element picks what it needs by these names. A name means the same in
every file; temperatures hold at zero stress, strain counts from unloaded austenite.
"""

from __future__ import annotations

# name -> (SI unit, meaning)
NAMES: dict[str, tuple[str, str]] = {
    "density": ("kg/m^3", "density"),
    "heat_capacity": ("J/kg/K", "specific heat capacity"),
    "latent_heat": ("J/kg", "latent heat of the whole transformation"),
    "thermal_conductivity": ("W/m/K", "thermal conductivity"),
    "E_A": ("Pa", "Young's modulus of austenite"),
    "E_M": ("Pa", "Young's modulus of martensite"),
    "Theta": ("Pa/K", "thermoelastic modulus; -E times the expansion"),
    "T_ref": ("K", "temperature of zero thermal strain"),
    "eps_L": ("1", "maximum recoverable strain"),
    "A_s": ("K", "austenite start temperature at zero stress"),
    "A_f": ("K", "austenite finish temperature at zero stress"),
    "M_s": ("K", "martensite start temperature at zero stress"),
    "M_f": ("K", "martensite finish temperature at zero stress"),
    "C_A": ("Pa/K", "Clausius–Clapeyron slope of the reverse transformation"),
    "C_M": ("Pa/K", "Clausius–Clapeyron slope of the forward transformation"),
    "sigma_s": ("Pa", "start stress of detwinning below M_s"),
    "sigma_f": ("Pa", "finish stress of detwinning below M_s"),
    "H_min": ("1", "transformation strain of martensite formed at no stress"),
    "H_sat": ("1", "transformation strain of martensite formed at high stress"),
    "H_k": ("1/Pa", "rate at which the transformation strain saturates with stress"),
    "sigma_crit": ("Pa", "stress at which the transformation strain begins to grow"),
    "sigma_cal": ("Pa", "stress at which both slopes of a Lagoudas set hold"),
    "n_1": ("1", "smooth hardening: roundness of the forward start"),
    "n_2": ("1", "smooth hardening: roundness of the forward end"),
    "n_3": ("1", "smooth hardening: roundness of the reverse end"),
    "n_4": ("1", "smooth hardening: roundness of the reverse start"),
    "waist_f": ("1", "waisted hardening: waist of the forward range"),
    "waist_r": ("1", "waisted hardening: waist of the reverse range"),
    "rho_A": ("ohm*m", "resistivity of austenite"),
    "rho_M": ("ohm*m", "resistivity of martensite"),
    "a_rho_A": ("1/K", "temperature coefficient of the resistivity of austenite"),
    "a_rho_M": ("1/K", "temperature coefficient of the resistivity of martensite"),
    "T_rho": ("K", "temperature at which both resistivities hold"),
    "nu": ("1", "Poisson's ratio"),
    "alpha_A": ("1/K", "thermal expansion of austenite"),
    "alpha_M": ("1/K", "thermal expansion of martensite"),
    "temperature_limit": ("K", "highest temperature without damage"),
    "stress_limit": ("Pa", "highest stress for long life"),
    "strain_limit": ("1", "largest strain amplitude for long life"),
    "eps_T": ("1", "transformation strain of one martensite variant"),
    "sigma_L": ("Pa", "stress of the austenite to martensite transition at T_L"),
    "T_L": ("K", "temperature at which sigma_L holds"),
    "dsigma_dT": ("Pa/K", "slope of the transition stresses with temperature"),
    "Delta_sigma": ("Pa", "width of the stress hysteresis"),
    "layer_volume": ("m^3", "volume of a transforming layer"),
    "layer_time": ("s", "time constant of a transforming layer"),
}
