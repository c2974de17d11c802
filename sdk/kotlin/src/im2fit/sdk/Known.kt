// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** Order of IM2FIT_SEX_... */
enum class Sex { UNKNOWN, WOMAN, MAN }

/** Facts of a [Known]. Order of the bits IM2FIT_KNOWN_... */
enum class KnownFact { STATURE, WEIGHT, SEX, AGE }

/**
 * Facts that the person reports. They are used together with the frames. A known weight makes girths more accurate. 0: unknown.
 *
 * @property statureMm barefoot, 500..2500
 * @property statureSdMm standard deviation; 0: 20, for a reported stature. Use 5 for a measured one
 * @property weightKg 15..400
 * @property weightSdKg 0: 3, for a reported weight. Use 0.7 for a weight from a scale
 * @property ageYears add 0.5 to completed years
 * @property ageSdYears 0: 0.5
 */
data class Known @JvmOverloads constructor(
    val statureMm: Float = 0f, val weightKg: Float = 0f, val sex: Sex = Sex.UNKNOWN, val ageYears: Float = 0f,
    val statureSdMm: Float = 0f, val weightSdKg: Float = 0f, val ageSdYears: Float = 0f
)
