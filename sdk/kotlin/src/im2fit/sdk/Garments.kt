// SPDX-License-Identifier: Apache-2.0
package im2fit.sdk

/** A garment (docs/garments.md): "t_shirt", "T-shirt". */
data class Garment(val id: String, val name: String)

/** All garments, named in "en", "de", "es", "fr" or "zh". */
fun garments(language: String = "en"): List<Garment> = (0 until Native.garmentCount()).map { index ->
    val words = arrayOfNulls<ByteArray>(2)
    Native.garmentWords(index, language.toByteArray(), words)
    val (id, name) = words.map { Native.text(it) }
    Garment(id!!, requireNotNull(name) { "no language '$language'" })
}

/** How a garment fits in a region. Order of IM2FIT_FIT_... */
enum class Fit {
    /** Too small: it constricts the body. */
    TIGHT,
    /** Closer than designed. */
    SNUG,
    /** As designed. */
    GOOD,
    /** Wider than designed. */
    LOOSE
}

/**
 * The fit of a garment in one region.
 *
 * @property ease girth of the finished garment minus girth of the body, mm
 */
data class PlaceFit(val ease: Estimate, val fit: Fit)

/**
 * How one size fits.
 *
 * @property cost 0: as designed in all regions. Comparable only between sizes of the same garment
 * @property places the regions by name: "chest", "waist", ...
 */
data class SizeFit(val size: String, val cost: Float, val places: Map<String, PlaceFit>)

/**
 * How each size of a garment fits the person, small to large.
 *
 * @property best the size to buy
 */
data class GarmentFit(val sizes: List<SizeFit>, val best: SizeFit) {
    /** Whether no size fits: [best] is tight in a region, or loose in all. */
    val noneFits: Boolean
        get() = best.places.values.run { any { it.fit == Fit.TIGHT } || all { it.fit == Fit.LOOSE } }
}

/**
 * A garment in a size. Null: in the best size.
 *
 * @property garment its id
 */
data class Worn(val garment: String, val size: String? = null)
