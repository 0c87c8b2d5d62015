//! The board's user LEDs and buttons, and the voltage of its supply.

use embassy_stm32::Peri;
use embassy_stm32::adc::{Adc, SampleTime};
use embassy_stm32::gpio::{AnyPin, Flex, Input, Level, Output, Pull, Speed};
use embassy_stm32::pac;
use embassy_stm32::peripherals::{ADC3, PC0};
use embassy_time::{Duration, Instant, Timer};

use crate::tasks::{Reporter, Shared};

/// As often as the stock firmware looks.
const PERIOD: Duration = Duration::from_millis(20);
/// The converter's full scale, V, and its count.
const REFERENCE_V: f32 = 3.3;
const FULL_SCALE: f32 = 4095.0;
/// 47 kΩ over 10 kΩ.
const DIVIDER: f32 = 5.7;

/// What the panel is made of.
pub(super) struct Parts {
    pub(super) leds: [Peri<'static, AnyPin>; 4],
    pub(super) buttons: [Peri<'static, AnyPin>; 2],
    pub(super) converter: Peri<'static, ADC3>,
    pub(super) supply: Peri<'static, PC0>,
}

/// Lit LEDs have their pin low; pressed buttons have theirs high.
pub struct Panel {
    leds: [Output<'static>; 4],
    buttons: [Input<'static>; 2],
    converter: Converter,
}

impl Panel {
    pub(super) fn new(parts: Parts) -> Self {
        Self {
            leds: parts.leds.map(|pin| Output::new(pin, Level::High, Speed::Low)),
            buttons: parts.buttons.map(|pin| Input::new(pin, Pull::None)),
            converter: Converter::new(parts.converter, parts.supply),
        }
    }

    /// Shows what the host wants and tells what there is, for good.
    pub async fn run(&mut self, shared: &Shared) -> ! {
        loop {
            let voltage = self.converter.exchange();
            shared.exchange_panel(|leds| {
                for (led, value) in self.leds.iter_mut().zip(leds) {
                    led.set_level(Level::from(value == 0));
                }
                let pressed = self.buttons.each_ref().map(|button| u8::from(button.is_high()));
                (pressed, voltage)
            });
            shared.report(Reporter::Panel, Instant::now().as_micros());
            Timer::after(PERIOD).await;
        }
    }
}

/// The supply's voltage, each time of the conversion that was started the time before: the HAL's
/// reading waits for its end, however long that takes.
struct Converter {
    /// Keeps clock and pin; it converts nothing.
    _adc: Adc<'static, ADC3>,
    _supply: Flex<'static>,
}

impl Converter {
    /// Sets the converter up for PC0 alone, which it calls its input 10 (DS10916, table 10).
    fn new(adc: Peri<'static, ADC3>, supply: Peri<'static, PC0>) -> Self {
        const INPUT: u8 = 10;
        let adc = Adc::new(adc);
        let mut supply = Flex::new(supply);
        supply.set_as_analog();
        // The first of the inputs from 10 on; a sequence of one.
        pac::ADC3.smpr1().modify(|register| register.set_smp(0, SampleTime::CYCLES144));
        pac::ADC3.sqr1().modify(|register| register.set_l(0));
        pac::ADC3.sqr3().modify(|register| register.set_sq(0, INPUT));
        Self { _adc: adc, _supply: supply }
    }

    /// What the last conversion found, V, if it has ended; begins the next.
    fn exchange(&mut self) -> Option<f32> {
        let is_done = pac::ADC3.sr().read().eoc();
        // Reading it clears the flag.
        let count = pac::ADC3.dr().read().data();
        pac::ADC3.cr2().modify(|register| register.set_swstart(true));
        is_done.then_some(f32::from(count) * (REFERENCE_V / FULL_SCALE * DIVIDER))
    }
}
