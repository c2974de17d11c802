// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** A garment that can be tried on (docs/garments.md): "t_shirt", "T-shirt". */
data class Garment(val id: String, val name: String)

/** All garments, named in "en", "de", "es", "fr" or "zh". */
fun garments(language: String = "en"): List<Garment> = (0 until Native.garmentCount()).map { index ->
    val words = arrayOfNulls<ByteArray>(2)
    Native.garmentWords(index, language.toByteArray(), words)
    val (id, name) = words.map { Native.text(it) }
    Garment(id!!, requireNotNull(name) { "no language '$language'" })
}

/** How a garment sits at a place. Order of IM2FIT_FIT_... */
enum class Fit {
    /** It binds. */
    TIGHT,
    /** Closer than meant. */
    SNUG,
    /** As meant. */
    GOOD,
    /** Wider than meant. */
    LOOSE
}

/**
 * A garment's fit at one place.
 *
 * @property ease what the finished girth has more than the body's, mm
 */
data class PlaceFit(val ease: Estimate, val fit: Fit)

/**
 * How one size sits.
 *
 * @property cost 0: as meant everywhere; comparable between sizes of one garment
 * @property places by name: "chest", "waist", ...
 */
data class SizeFit(val size: String, val cost: Float, val places: Map<String, PlaceFit>)

/**
 * How each size of a garment sits on the person, small to large.
 *
 * @property best the one to buy
 */
data class GarmentFit(val sizes: List<SizeFit>, val best: SizeFit) {
    /** Whether [best] is only the nearest: tight somewhere, or loose everywhere. */
    val noneFits: Boolean
        get() = best.places.values.run { any { it.fit == Fit.TIGHT } || all { it.fit == Fit.LOOSE } }
}

/**
 * A garment in a size; without one in the best.
 *
 * @property garment its id
 */
data class Worn(val garment: String, val size: String? = null)
