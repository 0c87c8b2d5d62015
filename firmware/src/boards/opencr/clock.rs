//! The clock tree: 25 MHz crystal to 216 MHz for the core, 48 MHz for USB, 54 and 108 MHz for the
//! peripherals.

use embassy_stm32::Config;
use embassy_stm32::rcc::{
    AHBPrescaler, APBPrescaler, Hse, HseMode, Pll, PllMul, PllPDiv, PllPreDiv, PllQDiv, PllSource, Sysclk,
    mux,
};
use embassy_stm32::time::Hertz;

/// As the stock firmware sets it. VCO 432 MHz, the most there is (RM0385, RCC_PLLCFGR); USB needs
/// 48 MHz ± 0.25 %.
pub(super) fn config() -> Config {
    let mut config = Config::default();
    config.rcc.hse = Some(Hse { freq: Hertz(25_000_000), mode: HseMode::Oscillator });
    config.rcc.pll_src = PllSource::HSE;
    config.rcc.pll = Some(Pll {
        prediv: PllPreDiv::DIV25,
        mul: PllMul::MUL432,
        divp: Some(PllPDiv::DIV2),
        divq: Some(PllQDiv::DIV9),
        divr: None,
    });
    config.rcc.sys = Sysclk::PLL1_P;
    config.rcc.ahb_pre = AHBPrescaler::DIV1;
    config.rcc.apb1_pre = APBPrescaler::DIV4;
    config.rcc.apb2_pre = APBPrescaler::DIV2;
    config.rcc.mux.clk48sel = mux::Clk48sel::PLL1_Q;
    config
}

/// Flash has seven wait states at 216 MHz, which this cache hides. The data cache stays off: see
/// docs/board.md.
pub(super) fn enable_instruction_cache() {
    if let Some(mut core) = cortex_m::Peripherals::take() {
        core.SCB.enable_icache();
    }
}
