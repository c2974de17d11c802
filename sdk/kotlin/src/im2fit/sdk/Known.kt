// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** Order of IM2FIT_SEX_... */
enum class Sex { UNKNOWN, WOMAN, MAN }

/** Facts of a [Known]. Order of the bits IM2FIT_KNOWN_... */
enum class KnownFact { STATURE, WEIGHT, SEX, AGE }

/**
 * What the person reports of themselves: evidence beside the frames. A known weight makes girths more accurate. 0: not known.
 *
 * @property statureMm barefoot, 500..2500
 * @property statureSdMm standard deviation; 0: 20, as people report it; 5: measured
 * @property weightKg 15..400
 * @property weightSdKg 0: 3, as people report it; 0.7: from a scale
 * @property ageYears add 0.5 to completed years
 * @property ageSdYears 0: 0.5
 */
data class Known @JvmOverloads constructor(
    val statureMm: Float = 0f, val weightKg: Float = 0f, val sex: Sex = Sex.UNKNOWN, val ageYears: Float = 0f,
    val statureSdMm: Float = 0f, val weightSdKg: Float = 0f, val ageSdYears: Float = 0f
)
